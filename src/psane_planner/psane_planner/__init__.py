# SPDX-License-Identifier: Apache-2.0
"""Certifies where the robot may walk and chooses where to look next."""
