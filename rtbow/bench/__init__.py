"""Speed against error: times, errors, memory and scaling of every method."""
