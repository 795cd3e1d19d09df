# SPDX-License-Identifier: Apache-2.0
"""What a leg feels: from noisy joints, wrenches and odometry to one record for each stance."""
