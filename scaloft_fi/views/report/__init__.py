"""A whole campaign in one HTML file that needs no network: figures as JSON, drawn in the page by plain JavaScript."""
