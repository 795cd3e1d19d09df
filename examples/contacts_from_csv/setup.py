# SPDX-License-Identifier: Apache-2.0
"""Install contacts_from_csv where ROS 2 looks for it."""

from setuptools import setup

package = 'contacts_from_csv'

setup(
    name=package,
    version='0.1.0',
    packages=[package],
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{package}']),
        (f'share/{package}', ['package.xml']),
        (f'share/{package}/data', ['data/contacts.csv']),
    ],
    zip_safe=False,
    maintainer='PSANE maintainers',
    maintainer_email='psane@example.com',
    description='Example: feeds the terrain mapper with stances from a table.',
    license='Apache-2.0',
    entry_points={'console_scripts': ['feed = contacts_from_csv.feed:main']},
)
