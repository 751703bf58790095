"""The robot of chapter 6 before recorded or present people: a wide video or a camera in place of the rendered world.

The robot's head turns by taking its image from another part of the wide image. The caregiver of chapter 6 never
answers the robot, so a recording is as good a world as a person.
"""
