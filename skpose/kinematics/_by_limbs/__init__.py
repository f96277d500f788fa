"""Retargeting by limbs: people onto robots, and other skeletons of hinges with limits.

What uses what::

    _targets                                     the steps, and where places on the robot shall be in each frame
       |
       +---- _results                            the motion that came of it, and how near it came
       |        |
       +---- _person                             the limbs, feet, pelvis and floor of the person
       |        |
       +---- _contacts                           when feet stand, and how they are held, by their soles
       |
       +---- _solver                             the poses whose places are nearest to where they shall be
       |        |
       +---- _stances                            landmarks of both that are counterparts
                |
             _places                             points on links, and how a skeleton stands at angle zero
                |
             _robots                             tables of the robots whose links are known
"""
