"""Server of the Model Context Protocol: commands as tools, and what they read as resources."""

DEFAULT_CALLS = 4
"""Commands that run at once."""
