"""What tests of several papers hold against them."""
