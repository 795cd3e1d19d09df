# SPDX-License-Identifier: Apache-2.0
"""Where the ground is soft: terrains by name, by file or from a seed."""
