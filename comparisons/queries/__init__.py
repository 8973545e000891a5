"""What a user asks of mbcheck, as functions: a request in, a result out."""
