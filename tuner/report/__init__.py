"""Reports of a results folder: one offline HTML page, and figures for a paper."""
