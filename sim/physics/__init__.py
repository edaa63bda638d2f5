"""Rigid bodies, grippers and sensors of one scene, in PyBullet and compiled ray casting."""
