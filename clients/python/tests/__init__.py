"""Tests of the client against a real daemon, which `cargo test -p genom-tests` starts.

GENOMD_SOCKET is the daemon's socket, GENOM_DEMO the demo component's library.
"""
