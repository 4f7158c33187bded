"""The sky: what air has scattered, solved for or known ahead, and tables of what an eye sees."""
