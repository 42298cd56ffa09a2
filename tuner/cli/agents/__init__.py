"""Server of the Model Context Protocol: commands as tools, and what they read as resources."""
