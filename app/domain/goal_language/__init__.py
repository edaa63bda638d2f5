"""The goal language: a grammar of sentences, completion, and checks of goals against a world and its facts. Pure."""
