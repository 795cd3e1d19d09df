# SPDX-License-Identifier: Apache-2.0
"""Maps of strength and slip from what legs feel."""
