"""Policies trained in one simulator, evaluated in others."""
