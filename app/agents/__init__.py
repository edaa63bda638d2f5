"""Agent models: the service's counterpart of each robot, and what is known of the robots right now (MACTA §4)."""

from app.agents.board import RobotBoard, RobotView
from app.agents.hearing import Hearing
from app.agents.models import AgentModels
from app.agents.questions import Questions

__all__ = ["AgentModels", "Hearing", "Questions", "RobotBoard", "RobotView"]
