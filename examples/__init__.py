"""Engines plugged into mbcheck, written as anyone else would write theirs."""
