# SPDX-License-Identifier: Apache-2.0
"""The server of the live view: what listens where, and the light of the scene."""

import contextlib
import io
import socket

import viser

from psane_sim.errors import SimulationError

LOOPBACK = '127.0.0.1'


class ViewError(SimulationError, RuntimeError):
    """The live view cannot be served."""


def free_port(host: str = LOOPBACK) -> int:
    """Return a port that nobody listens on at this moment."""
    with socket.socket() as probe:
        probe.bind((host, 0))
        return int(probe.getsockname()[1])


def open_server(host: str = LOOPBACK, port: int = 0) -> viser.ViserServer:
    """Serve an empty scene.

    Parameters
    ----------
    host : str
        Address to listen on; the loopback one is seen by this machine alone.
    port : int
        0 for any that is free.

    Raises
    ------
    ViewError
        When the port is taken or the address is not one of this machine.
    """
    try:
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind((host, port))
    except OSError as error:
        raise ViewError(f'cannot listen on {host}:{port}: {error.strerror}') from error
    # The server greets with a frame of its own; the address is said by who opens it.
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=host, port=port or free_port(host), label='PSANE',
                                   verbose=False)
    server.scene.world_axes.visible = False
    server.scene.configure_default_lights(True, cast_shadow=False)
    return server


def address_of(server: viser.ViserServer) -> str:
    """Return what to type into a browser."""
    return f'http://{server.get_host()}:{server.get_port()}'
