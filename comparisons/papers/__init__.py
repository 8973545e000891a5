"""The papers reproduced: their figures, and a ledger of what they print and claim."""
