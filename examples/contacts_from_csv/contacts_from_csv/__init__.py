# SPDX-License-Identifier: Apache-2.0
"""Feeds the terrain mapper with stances from a table."""
