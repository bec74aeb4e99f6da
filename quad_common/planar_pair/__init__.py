"""
A body on two legs in the plane (S3).
"""
