"""Queries of users as functions: a request in, a result out."""
