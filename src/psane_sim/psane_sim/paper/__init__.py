# SPDX-License-Identifier: Apache-2.0
"""The paper's experiments: tasks, ablations, tables, figures and one page."""
