"""
Experiments: closed loops without topics, walks over topics, benchmarks, and papers drawn again.
"""
