"""Robots' packets tuned at run time: what operators wish, and how far it has come to the robots."""

from app.tuning.desk import TunedRobot, TuningDesk

__all__ = ["TunedRobot", "TuningDesk"]
