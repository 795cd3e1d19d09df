# SPDX-License-Identifier: Apache-2.0
"""The live view in a browser, and the page of a run that it leaves."""
