# SPDX-License-Identifier: Apache-2.0
"""Make `data/contacts.csv`: the stances of a simulated robot that walks over the world env1.

From the repository's folder: ./psane shell python examples/contacts_from_csv/make_table.py
"""

import argparse
import csv
from pathlib import Path

from contacts_from_csv.table import SAMPLE_COLUMNS, STANCE_COLUMNS

from psane_mapping.contact import LegContact
from psane_mapping.leg import RobotModel
from psane_sim.configuration import SimulatorConfiguration
from psane_sim.robot.hexapod import HexapodSimulator
from psane_sim.terrains.catalogue import load_terrain
from psane_sim.touch.configuration import TouchConfiguration
from psane_sim.touch.contact_sensing import ContactSensor
from psane_sim.touch.sensing import Sensors

TABLE = Path(__file__).resolve().parent / 'data' / 'contacts.csv'
COMMAND = (0.2, 0.0)
"""Forward speed and yaw rate that the robot is told [m/s], [rad/s]."""


def walk(duration: float, seed: int) -> list[LegContact]:
    """Return the stances of a walk of some seconds, noise and all."""
    configuration, terrain = SimulatorConfiguration(), load_terrain('env1')
    simulator = HexapodSimulator(configuration, terrain, terrain.start_pose, robot=RobotModel())
    sensors, touch = Sensors(configuration, seed), ContactSensor(TouchConfiguration(),
                                                                 RobotModel())
    contacts = []
    for tick in range(0, round(1000 * duration), 5):
        simulator.command(*COMMAND)
        simulator.step(5)
        truth = simulator.truth()
        if tick % 20 == 0:
            touch.set_odometry(sensors.odometry(truth))
        contacts += touch.update(sensors.joints(truth), sensors.wrenches(truth),
                                 sensors.imu(truth))
    simulator.close()
    return contacts


def write_table(path: Path, contacts: list[LegContact], every: int) -> None:
    """Write one row for every so many samples of each stance."""
    with path.open('w', newline='', encoding='utf-8') as file:
        file.write('# SPDX-License-Identifier: Apache-2.0\n'
                   '# Stances of the simulated hexapod on env1; units: s, m, N (see README.md).\n')
        table = csv.writer(file, lineterminator='\n')
        table.writerow([*STANCE_COLUMNS, *SAMPLE_COLUMNS])
        for number, contact in enumerate(contacts):
            common = [number, contact.leg, f'{contact.touch_down:.3f}', f'{contact.lift_off:.3f}',
                      f'{contact.point[0]:.4f}', f'{contact.point[1]:.4f}',
                      f'{contact.point_deviation:.4f}', int(contact.has_velocity)]
            for row in range(0, contact.depth.size, every):
                forces = [f'{value:.2f}' for kind in ('measured', 'response', 'deviation')
                          for value in getattr(contact, kind)[row]]
                table.writerow([*common, f'{contact.depth[row]:.5f}', *forces])


def main() -> None:
    """Walk and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--duration', type=float, default=12.0, help='simulated time [s]')
    parser.add_argument('--seed', type=int, default=0, help='seed of the noise')
    parser.add_argument('--every', type=int, default=4, help='samples that make one row')
    parser.add_argument('--out', type=Path, default=TABLE)
    options = parser.parse_args()
    contacts = walk(options.duration, options.seed)
    write_table(options.out, contacts, options.every)
    print(f'{len(contacts)} stances, {options.out.stat().st_size} bytes: {options.out}')


if __name__ == '__main__':
    main()
