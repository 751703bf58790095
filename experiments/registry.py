"""All claims by id. A claim is one entry here and one folder beside this file.

In the folder, ``sweep.py`` has ``SETTINGS`` and ``trial``. It has ``FIRST_SEED`` and ``VERSION`` if they are not 0 and
1, and ``FILM``, the path of a short video, if there is one. ``analysis.py`` has ``analyse`` and ``draw``. ``README.md``
says what came out. The modules are imported when they are first needed.
"""

from jointattn_mj.sweeps.registry import Entry, Registry

REGISTRY = Registry(
    __package__,
    Entry("4.4", "detection", "Which event is contingent", "section 4.5.2, Fig. 4.4",
          "T^C of (S1, A1, R2) becomes the highest; after about 30,000 steps nothing changes any more."),
    Entry("4.5", "many_objects", "More and fewer objects", "section 4.5.2, Fig. 4.5",
          "The right event leads unless 8 or 9 of 9 spots are full; p_r and p_i do not matter."),
    Entry("4.6", "careless_caregiver", "A caregiver who does not look at objects", "section 4.5.3, Fig. 4.6",
          "The right event leads above p_c = 0.6, and below 0.2, where the opposite is contingent."),
    Entry("4.7", "experience", "What was found by following by chance", "section 4.5.4, Fig. 4.7",
          "Objects are found most often where the caregiver looks."),
    Entry("4.5.4", "perceptron", "Learning gaze following from the chosen pair", "section 4.5.4",
          "A two-layered perceptron reaches 84% success over ten trials."),
    Entry("measures", "measures", "Other measures on the same data", "section 4.6, left for the future",
          "Transfer entropy should beat mutual information and Granger causality; not tried."),
    Entry("5.2", "order", "Gaze following, looking back, gaze alternation", "section 5.3.2",
          "In 90% of ten runs these three modules are made in this order; 3.5 modules a run."),
    Entry("5.3", "time_course", "Contingency over time", "section 5.3.2, Fig. 5.3",
          "What a module reproduces sinks in the ranking and lets the next event rise."),
    Entry("5.4", "caregiver_settings", "Other caregivers", "section 5.3.3, Fig. 5.4",
          "With p_e = 1 the three modules come for most p_r and p_i; with p_e = 0 others come after gaze following."),
    Entry("5.5", "behaviour", "How behaviour changes", "section 5.4, Fig. 5.5",
          "The first two modules change behaviour little; gaze alternation changes it drastically."),
    Entry("fast", "fast", "Contingency in fewer steps", "section 7.1, asked for",
          "More than 45,000 steps are more than a person can be asked for."),
    Entry("local", "local", "Contingency within an hour", "section 7.1, asked for",
          "More than 45,000 steps are more than a person can be asked for."),
    Entry("ablations", "ablations", "What each open choice of chapter 5 changes", "sections 5.2 and 5.3",
          "The text leaves these open."),
    Entry("6.6", "som", "The map of face patterns", "section 6.4.1, Fig. 6.6",
          "Faces seen in three minutes are ordered on a map of 9 x 9 units: similar faces have neighbouring units."),
    Entry("6.7", "synchronised", "The gate, and the synchronised run behind it", "section 6.4.1, Fig. 6.7",
          "The gate was set from a run in which robot and person keep time: half open at the 150th learning step."),
    Entry("6.8", "sessions", "Gaze following in real time", "section 6.4.3, Fig. 6.8",
          "In 26 minutes the robot learns to look where the person looks, better with motion cues than without: "
          "199.6 successes in 302.0 gaze shifts against 124.4 in 279.6, and a rate of 0.8 after 20 minutes."),
    Entry("drawing", "drawing", "Other ways of drawing and of moving", "not in the dissertation",
          "Its robot has a camera. Here images are most of the computing time, and can be had for less."),
    Entry("maps", "wrong_map", "Why some sessions without motion cues hold on to a wrong map", "section 6.4.3",
          "Without motion cues learning is worse; the text does not ask by which link."),
    Entry("contingent", "cross_situational", "Gaze following without wrong maps", "section 6.4.3",
          "With motion cues the robot pairs a face with the right object more often, and so learns better: a rate of "
          "0.8 after 20 minutes."),
    Entry("looks", "looks", "Coding where a person looks, without labels", "not in the dissertation",
          "What tells the robot where a person looks can tell it to whoever codes a video by hand."),
    Entry("baselines", "turn_taking", "Constrained turn taking with the three-layered network", "reference [19]",
          "Success starts at chance and becomes high with 1, 3, 5 and 10 objects; three stages appear, as in infants: "
          "any object, the right one in view, the right one outside the view."),
    Entry("follow", "follow", "Reward in place of contingency: PPO on the task follow", "not in the dissertation",
          "Its robot is never told that it was right. A learner that is told at every step gives a measure of the "
          "task."),
    Entry("continuous", "continuous", "Gaze following in continuous space", "section 7.1, asked for",
          "Once its event is found, a module learns a map from continuous data, by the pairs that contingent saliency "
          "marks as informative."),
    Entry("rendered", "rendered", "Development on a robot that sees, step by step", "sections 5.3 and 7.1",
          "To validate our mechanism, we need to implement our mechanism into a real robot."),
    Entry("resolution", "resolution", "Resolution that grows", "section 7.1, asked for",
          "How fine variables are influences contingency, and was set in advance; it should improve along with the "
          "robot's development."),
    Entry("realtime", "realtime", "Development in real time", "section 7.1, asked for",
          "A person can keep up an hour of interaction; 45,000 steps they cannot."),
)  # fmt: skip
