"""Agent models and communications (MACTA §4, fig. 4): the service's counterpart of each robot."""

from app.agents.agent_models import AgentModels
from app.agents.contact_monitor import ContactMonitor
from app.agents.questions import Questions
from app.agents.robot_board import RobotBoard, RobotView

__all__ = ["AgentModels", "ContactMonitor", "Questions", "RobotBoard", "RobotView"]
