# SPDX-License-Identifier: Apache-2.0
"""Recording and replaying rosbag2 bags, and the bags that the tests replay."""
