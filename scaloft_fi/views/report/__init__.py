"""One HTML file that tells a whole campaign, offline: figures as JSON, drawn in the page by plain JavaScript."""
