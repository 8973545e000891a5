"""Campaigns: honest variations and seeded faults, drawn at random."""
