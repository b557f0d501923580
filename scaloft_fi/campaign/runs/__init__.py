"""Run a plan: fly what is missing, within limits if the user sets any, and check the gates."""
