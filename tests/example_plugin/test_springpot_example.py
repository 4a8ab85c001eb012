import springpot_example

from springpot.testing import PluginContract


class TestExample(PluginContract):
    plugin = springpot_example
    passive = True
