# SPDX-License-Identifier: Apache-2.0
"""Many runs: random terrains, and the workers that share them."""
