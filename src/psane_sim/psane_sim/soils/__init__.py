# SPDX-License-Identifier: Apache-2.0
"""The ground under the robot: laws of soils, the soils that there are, and its surface."""
