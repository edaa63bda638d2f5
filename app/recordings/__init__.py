"""Recordings of missions: what was decided, told and done, and where robots were; MCAP files that can be replayed."""

from app.recordings.recorder import Recorder
from app.recordings.replay import replay_of
from app.recordings.shelf import Recording, Shelf

__all__ = ["Recorder", "Recording", "Shelf", "replay_of"]
