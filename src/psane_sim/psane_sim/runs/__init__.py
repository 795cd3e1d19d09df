# SPDX-License-Identifier: Apache-2.0
"""The stack in one process, and what is kept, scored and drawn of a run."""
