"""The folder of a campaign: a name, or a path that the system accepts."""

from __future__ import annotations

import pytest

from scaloft_fi.campaign.store.archive import campaign_folder
from scaloft_fi.errors import InputError
from scaloft_fi.study import Study


@pytest.mark.parametrize("name", ["~nosuchuser/a", "/" + "a" * 300, "a/b\0", "a" * 256, "é" * 128, "..", " ", "a\0"])
def test_a_name_that_the_system_refuses_is_refused_in_a_sentence(tmp_path, name):
    with pytest.raises(InputError, match=r"^--campaign: name=.* must be the (path|name) of a folder"):
        campaign_folder(Study(tmp_path), name)


def test_a_name_stands_for_a_folder_of_the_results_and_a_path_for_itself(tmp_path):
    assert campaign_folder(Study(tmp_path), "a" * 255).parent == tmp_path / "results" / "campaigns"
    assert campaign_folder(Study(tmp_path), f"{tmp_path}/new") == tmp_path / "new"
