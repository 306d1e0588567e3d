"""The arm and its gripper: models, servo, and the grasp as phases."""
