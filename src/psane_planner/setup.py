# SPDX-License-Identifier: Apache-2.0
"""Install psane_planner where ROS 2 looks for it."""

from glob import glob

from setuptools import find_packages, setup

package = 'psane_planner'

setup(
    name=package,
    version='0.1.0',
    packages=find_packages(include=[package, f'{package}.*']),
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{package}']),
        (f'share/{package}', ['package.xml']),
        (f'share/{package}/config', sorted(glob('config/*.yaml'))),
    ],
    zip_safe=False,
    maintainer='PSANE maintainers',
    maintainer_email='psane@example.com',
    description='Certifies where the robot may walk and chooses where to look next.',
    license='Apache-2.0',
    entry_points={
        'console_scripts': [
            'safe_planner = psane_planner.safe_planner_node:main',
        ],
    },
)
