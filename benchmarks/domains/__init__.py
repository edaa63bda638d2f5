"""Our planner beside Fast Downward, LPG and Aries on eight planning domains that are not about robots' packets."""
