"""Inverse kinematics of several sections: closed form as far as it goes, least squares on the Jacobian beyond."""
