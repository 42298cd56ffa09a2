"""A local page on which gains are moved by hand: responses, loops and limits follow."""
