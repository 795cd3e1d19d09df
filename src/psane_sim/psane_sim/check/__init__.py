# SPDX-License-Identifier: Apache-2.0
"""Whether a robot's topics are what the stack needs."""
