# SPDX-License-Identifier: Apache-2.0
"""Install psane_mapping where ROS 2 looks for it."""

from glob import glob

from setuptools import find_packages, setup

package = 'psane_mapping'

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
    description='Feels the strength of granular ground through the legs and maps it '
                'with a Gaussian process.',
    license='Apache-2.0',
    entry_points={
        'console_scripts': [
            'fit = psane_mapping.fit:main',
            'terrain_mapper = psane_mapping.terrain_mapper_node:main',
        ],
    },
)
