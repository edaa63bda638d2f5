"""Agent models: the service's counterpart of each robot, and what is known of the robots right now (MACTA §4)."""

from app.agents.agent_models import AgentModels
from app.agents.contact_monitor import ContactMonitor
from app.agents.questions import Questions
from app.agents.robot_board import RobotBoard, RobotView

__all__ = ["AgentModels", "ContactMonitor", "Questions", "RobotBoard", "RobotView"]
