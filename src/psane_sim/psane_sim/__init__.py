# SPDX-License-Identifier: Apache-2.0
"""A six-legged robot on granular ground, its sense of touch, and the demo."""
