"""What every part of a world file is."""

from pydantic import BaseModel, ConfigDict


class Part(BaseModel):
    """Base of every part of a world file: immutable, unknown keys are an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)
