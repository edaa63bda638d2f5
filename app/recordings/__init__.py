"""Recordings of missions: decisions, reports, events and robots' poses, as MCAP files that can be replayed."""

from app.recordings.mind_sampler import MindSampler
from app.recordings.recorder import Recorder
from app.recordings.recording_store import Recording, RecordingStore
from app.recordings.replay import replay_of

__all__ = ["MindSampler", "Recorder", "Recording", "RecordingStore", "replay_of"]
