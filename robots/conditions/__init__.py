"""Sensor conditions: what starts, sustains and ends a behaviour packet (MACTA §3).

A condition answers whether it holds, and describes in words what was perceived. All are named, so that data can state
and compose them.
"""
