# SPDX-License-Identifier: Apache-2.0
"""Install psane_sim where ROS 2 looks for it."""

from glob import glob

from setuptools import find_packages, setup

package = 'psane_sim'

setup(
    name=package,
    version='0.1.0',
    packages=find_packages(include=[package, f'{package}.*']),
    package_data={package: ['data/*', 'data/*/*']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{package}']),
        (f'share/{package}', ['package.xml']),
        (f'share/{package}/config', sorted(glob('config/*.yaml'))),
        (f'share/{package}/rviz', sorted(glob('rviz/*.rviz'))),
        (f'share/{package}/foxglove', sorted(glob('foxglove/*.json'))),
    ],
    zip_safe=False,
    maintainer='PSANE maintainers',
    maintainer_email='psane@example.com',
    description='A six-legged robot on granular ground in pybullet, its contact '
                'sensing, and the demo.',
    license='Apache-2.0',
    entry_points={
        'console_scripts': [
            'hexapod_sim = psane_sim.hexapod_sim_node:main',
            'contact_sensor = psane_sim.contact_sensor_node:main',
            'demo = psane_sim.demo.command:main',
            'bench = psane_sim.bench:main',
            'benchmark = psane_sim.benchmark:main',
            'touch_report = psane_sim.touch.report:main',
            'calibrate = psane_sim.calibration.calibrate:main',
            'soil_figures = psane_sim.soils.figures:main',
            'check = psane_sim.check.command:main',
            'record = psane_sim.bags.record:main',
            'replay = psane_sim.bags.replay:main',
            'viewer = psane_sim.viewer.command:main',
            'record_test_bags = psane_sim.bags.record_test_bags:main',
        ],
    },
)
