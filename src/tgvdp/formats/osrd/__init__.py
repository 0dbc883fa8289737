"""OSRD: rolling stock as RailJSON (`stock`), and paths with their speed limits as its services answer (`path`)."""
