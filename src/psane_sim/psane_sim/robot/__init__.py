# SPDX-License-Identifier: Apache-2.0
"""The simulated hexapod: its body, its gait, the engine that moves it, and pictures of it."""
