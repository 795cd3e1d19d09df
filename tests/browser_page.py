# SPDX-License-Identifier: Apache-2.0
"""A page in a headless Chromium, and where points of the world are on what it draws."""

import io
import shutil
import time

import numpy as np
from matplotlib import image as pictures
from node_process import PATIENCE

CHROMIUM = next((path for name in ('chromium', 'chromium-browser', 'google-chrome')
                 if (path := shutil.which(name))), None)
WITHOUT = 'there is no chromium here: apt-get install chromium'

SOFTWARE_GRAPHICS = (
    '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
    '--ignore-gpu-blocklist', '--disable-background-networking')
WIDTH, HEIGHT = 760, 300
"""Of a page: small, for without a graphics card its processor draws every dot of it."""



class Page:
    """A page that was opened, and all that it asked for.

    Parameters
    ----------
    browser : playwright's Browser
    address : str
    """

    def __init__(self, browser, address):
        self.requests = []
        self.page = browser.new_page(viewport={'width': WIDTH, 'height': HEIGHT})
        self.page.on('request', lambda request: self.requests.append(request.url))
        self.page.on('websocket', lambda socket: self.requests.append(socket.url))
        self.page.goto(address, timeout=1e3 * PATIENCE)

    def picture(self):
        """Return the left part of the page, where no panel is, (height, width, 3) in 0..1."""
        shot = self.page.screenshot(timeout=1e3 * PATIENCE)
        return pictures.imread(io.BytesIO(shot), format='png')[:, 330:430, :3]

    def wait_for_change(self, before, dots):
        """Wait until so many dots differ from an earlier picture."""
        self.wait(lambda: changed(before, self.picture()).sum() >= dots)

    def wait(self, condition):
        """Wait until a condition holds; fail when it never does."""
        end = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < end, 'waited in vain'
            self.page.wait_for_timeout(100)

    def outside_requests(self, *own):
        """Return what was asked of anybody but the addresses that begin like this."""
        return [url for url in self.requests
                if not url.startswith((*own, 'data:', 'blob:'))]


def drawn_by(client, width, height):
    """Return what a page draws, (height, width, 3) in 0..1, drawn for us in that size."""
    return client.get_render(height, width, transport_format='png')[..., :3] / 255.0


def changed(before, after):
    """Return the dots (height, width) that differ clearly between two pictures."""
    return np.abs(before - after).max(axis=2) > 0.1


def pixel_of(camera, point, width, height):
    """Return where a point (3,) of the world is on a picture, (x, y).

    Parameters
    ----------
    camera : viser's CameraHandle
        Of the client that draws.
    """
    w, x, y, z = camera.wxyz
    rotation = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    right, down, ahead = rotation.T @ (np.asarray(point) - camera.position)
    focal = height / 2.0 / np.tan(camera.fov / 2.0)
    return np.array([width / 2.0 + focal * right / ahead, height / 2.0 + focal * down / ahead])
