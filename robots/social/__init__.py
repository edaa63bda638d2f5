"""The social level: speech acts between robots, conversations, acquaintances, clearance from robot to robot."""

from robots.social.acquaintances import Acquaintance, Acquaintances
from robots.social.conversation import Conversation, Conversations, OutOfProtocol
from robots.social.level import SocialLevel
from robots.social.rule_speech import RuleSpeech
from robots.social.speech import Ending, Heard, Reply, content_of
from robots.social.terms import ContentError, Term, parse_term

__all__ = [
    "Acquaintance",
    "Acquaintances",
    "ContentError",
    "Conversation",
    "Conversations",
    "Ending",
    "Heard",
    "OutOfProtocol",
    "Reply",
    "RuleSpeech",
    "SocialLevel",
    "Term",
    "content_of",
    "parse_term",
]
