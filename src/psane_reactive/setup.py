# SPDX-License-Identifier: Apache-2.0
"""Install psane_reactive where ROS 2 looks for it."""

from glob import glob

from setuptools import find_packages, setup

package = 'psane_reactive'

setup(
    name=package,
    version='0.1.0',
    packages=find_packages(include=[package, f'{package}.*']),
    package_data={package: ['data/*']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{package}']),
        (f'share/{package}', ['package.xml']),
        (f'share/{package}/config', sorted(glob('config/*.yaml'))),
    ],
    zip_safe=False,
    maintainer='PSANE maintainers',
    maintainer_email='psane@example.com',
    description='Steers to the subgoal without leaving certified ground.',
    license='Apache-2.0',
    entry_points={
        'console_scripts': [
            'reactive_controller = psane_reactive.reactive_controller_node:main',
        ],
    },
)
